#!/usr/bin/env bash
# Makes sure that Rust is there, and a linker for it: a bare system with rustup has none. Nothing but
# the tests needs more: they compare with a measure written in C++.
set -euo pipefail
source "$(dirname "$0")/packages.sh"

if ! command -v cargo >/dev/null; then
    explain "no Rust." "Install it from https://rustup.rs and open a new shell."
    exit 1
fi
if [[ $(uname -s) == Linux ]] && ! command -v cc >/dev/null; then
    install_packages "no linker (cc)." gcc libc6-dev
fi
if [[ $(uname -s) == Linux ]] && ! command -v c++ >/dev/null; then
    install_packages "no C++ compiler (c++), which the tests need." g++
fi
