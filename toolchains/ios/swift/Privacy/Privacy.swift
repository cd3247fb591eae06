// Nothing: a target with a resource needs a source.
