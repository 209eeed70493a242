#!/usr/bin/env bash
# Makes sure that the libraries which the window opens at run time are there. Without a display there
# is no window, and nothing to install. A window is not worth failing for: without the libraries
# the program says so and draws to files.
set -euo pipefail
source "$(dirname "$0")/packages.sh"

[[ $(uname -s) == Linux ]] || exit 0
missing=()
need() {
    has_library "$1" || missing+=("$2")
}
if [[ -n ${WAYLAND_DISPLAY:-} ]]; then
    need libwayland-client.so.0 libwayland-client0
    need libxkbcommon.so.0 libxkbcommon0
elif [[ -n ${DISPLAY:-} ]]; then
    need libX11.so.6 libx11-6
    need libX11-xcb.so.1 libx11-xcb1
    need libXcursor.so.1 libxcursor1
    need libXi.so.6 libxi6
    need libXrandr.so.2 libxrandr2
    need libxkbcommon.so.0 libxkbcommon0
    need libxkbcommon-x11.so.0 libxkbcommon-x11-0
fi
if [[ ${#missing[@]} -gt 0 ]]; then
    install_packages "libraries of the window are missing." "${missing[@]}" || true
fi
