"""What a doubt is worth in a plan: choices with the averaged mission, the best cause alone and the base model."""
