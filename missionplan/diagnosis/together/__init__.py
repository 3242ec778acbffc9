"""Several data sets of one campaign, diagnosed into one extended mission."""
