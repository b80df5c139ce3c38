"""Campaigns: many runs of one scenario, in blocks, on this machine or on a cluster, resumable."""
