"""Kernels that detection and tracking share: plain arrays in and out, no config, no random state."""
