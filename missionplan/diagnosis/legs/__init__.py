"""Navigation logs: model, covariance and designs of further legs. Read first `model`, then `mean` and `noise`."""
