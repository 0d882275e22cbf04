"""What programs call: the commands of the command line as functions, on meshes in memory too.

The package hands these on: `import meshopt_cli as meshopt; meshopt.optimize(...)`.
"""
