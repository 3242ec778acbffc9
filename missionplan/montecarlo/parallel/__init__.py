"""Work shared among processes: `blocks` of trials and parts of calls, on one `pool` or a Dask cluster's workers."""
