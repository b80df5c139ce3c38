"""Rerun recordings and their blueprints. The only room with rerun."""
