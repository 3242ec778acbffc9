"""Report of `import`: what was made of a vehicle's logs (`page`), and its figures."""
