"""Where captures come from; one file a kind of source. No source knows what a frame is."""
