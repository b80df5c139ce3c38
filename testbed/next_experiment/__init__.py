"""Where a diagnosis ends with look-alikes: the next flight, which tells them apart."""
