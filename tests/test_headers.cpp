// Nothing of its own: the target compiles the headers that every test includes.
