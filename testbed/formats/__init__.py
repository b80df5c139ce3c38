"""The JSON files that the testbed writes, described key by key: their schemas, for programs that read them."""
