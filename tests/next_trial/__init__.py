"""Trials at a made-up sea: what was predicted of their worth, beside what they brought."""
