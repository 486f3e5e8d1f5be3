"""How results are laid out for people; one file a form. No report decides what is said."""
