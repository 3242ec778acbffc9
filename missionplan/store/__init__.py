"""Files on disk: written beside and renamed into place; finished blocks of trials."""
