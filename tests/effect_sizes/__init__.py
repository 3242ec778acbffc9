"""Sizes of effects as they are estimated: a study of bias and of intervals from 0.3 to 10 times the usual size."""
