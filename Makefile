# Each target does its own set-up on a machine with Rust, gcc, Python 3 and make.

CARGO = . tools/native-env.sh && cargo

.PHONY: demo test bench fmu python clean

demo: ## run the whole chain on one turn of damped torsion
	@$(CARGO) run --quiet --release -- demo

test: python ## all tests, FMPy's included
	@$(CARGO) test --workspace

bench: ## timings beside peers, as ratios of one run
	@sh tools/python-env.sh || echo "struna: going on without the peers that need Python" >&2
	@$(CARGO) bench -p struna --bench ratios --quiet

fmu: ## build the FMUs into out/fmu
	@$(CARGO) run --quiet --release -- fmu build

python:
	@sh tools/python-env.sh

clean: ## remove everything that was built or installed here
	@cargo clean --quiet
	@rm -rf .venv out
