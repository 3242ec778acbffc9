"""Files on disk: report folders, written atomically, and checkpoints of finished blocks of trials."""
