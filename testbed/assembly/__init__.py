"""From a scenario, in the units of its file, to the objects of the rooms below, in SI; every conversion is here."""
