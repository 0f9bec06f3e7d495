"""The truth layer's arithmetic, body by body: after a simulator's step, numpy's many calls on few bodies are dear."""
