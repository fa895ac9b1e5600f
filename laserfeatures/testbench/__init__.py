"""The paper's tables and figures run again, beside its own numbers."""
