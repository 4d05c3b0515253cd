# Installation rules and the exported package.
