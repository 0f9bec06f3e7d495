"""Confidence intervals for few seeds or vehicles: one method for reports, comparisons and studies."""
