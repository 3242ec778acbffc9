"""What readers share: tables of text, NetCDF, files of fixes, columns and channels, and how logs write numbers."""
