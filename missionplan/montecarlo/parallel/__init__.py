"""Work shared among processes: `blocks` of trials and `mapping` of calls, on one `pool` or a Dask cluster's workers."""
