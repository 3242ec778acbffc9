"""Report of `score`: the answer in a sentence, the table of yardsticks, and how the predictions spread."""
