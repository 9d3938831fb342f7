"""Which of the scored designs to build, with reasons, and the thesis' claims about them."""
