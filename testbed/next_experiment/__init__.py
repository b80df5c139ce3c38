"""Where a diagnosis ends with indistinguishable effects: the next flight, which distinguishes them."""
