"""What `import testbed` offers: the same steps as the command line's, as functions on objects."""
