"""Logs of other programs: read, mapped to records; records written as MCAP."""
