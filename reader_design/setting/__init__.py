"""A study in computable form: scene, tags, the reader and its response, links, samples, scores."""
