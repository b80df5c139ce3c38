"""From measured records to the inertia: the gate, an estimate for each record, their agreement and combination."""
