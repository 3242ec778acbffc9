"""What one section alone cannot show: phases in order, names, correlations, requirements."""
