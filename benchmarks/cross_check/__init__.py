"""One mission in several simulators, with propmap's loads and with the hover model."""
