# The three commands of the project. Each does the set-up it needs; see scripts/.
#
#   make run     fly over the demo: a window, or PNG files where there is no display
#   make test    every test, on a GPU or on Mesa's software Vulkan driver
#   make check   format, lints, documentation, licences and source rules
#
# `make run PROFILE=dev` shares its build with the tests instead of making the optimised one.

PROFILE ?= release
ARGS ?=

.PHONY: run test check build-tools vulkan window

run: build-tools vulkan window
	cargo run --quiet --locked --profile $(PROFILE) --package app -- $(ARGS)

test: build-tools vulkan
	cargo test --locked --workspace

check: build-tools
	cargo fmt --all --check
	cargo clippy --locked --workspace --all-targets -- -D warnings
	RUSTDOCFLAGS="-D warnings" cargo doc --locked --workspace --no-deps
	cargo test --locked --workspace --test licences --test source_rules --test documents

build-tools:
	@scripts/ensure_build_tools.sh

vulkan:
	@scripts/ensure_vulkan.sh

window:
	@scripts/ensure_window.sh
