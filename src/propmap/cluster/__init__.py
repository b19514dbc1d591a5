"""Tasks on a Dask cluster; needs the extra ``cluster``."""
