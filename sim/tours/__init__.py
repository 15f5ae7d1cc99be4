"""Where tours go and how: stops and their order, kinds of tours, smooth ways, views and pace."""
