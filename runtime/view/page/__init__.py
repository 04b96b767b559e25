"""The operator's page: files that a browser is given as they are. No step builds them, and they ask
nobody but the server that they came from. `main.js` puts the parts together."""
