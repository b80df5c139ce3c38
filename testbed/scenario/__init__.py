"""The scenario schema and its reader. The only room that validates."""
