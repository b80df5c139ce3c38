"""The frame of every report: one self-contained HTML page of sections, tables, charts and listings."""
