# Sourced by the ensure_*.sh scripts: finding shared libraries, installing Debian packages.

# Whether the dynamic linker finds the shared library $1 (such as libvulkan.so.1).
has_library() {
    local listing
    # Read whole before searching: under pipefail an early exit of grep would fail the pipe.
    listing=$(PATH="$PATH:/sbin:/usr/sbin" ldconfig -p 2>/dev/null || true)
    [[ $listing == *"$1 "* ]]
}

# Installs Debian packages: install_packages REASON PACKAGE...
# Returns 1, having said what to install by hand, where it cannot.
install_packages() {
    local reason=$1
    shift
    local as_root=()
    if ! command -v apt-get >/dev/null; then
        explain "$reason" "Install what your system calls: $*"
        return 1
    fi
    if [[ $(id -u) -ne 0 ]]; then
        # Without a terminal sudo cannot ask for a password, so it must not try.
        if ! command -v sudo >/dev/null || { [[ ! -t 0 ]] && ! sudo -n true 2>/dev/null; }; then
            explain "$reason" "Run as root: apt-get install $*"
            return 1
        fi
        as_root=(sudo)
    fi
    echo "terrain: $reason Installing $* ..." >&2
    "${as_root[@]}" apt-get update -qq >&2
    "${as_root[@]}" env DEBIAN_FRONTEND=noninteractive \
        apt-get install -y -qq --no-install-recommends "$@" >&2
}

# Prints a problem and its way out.
explain() {
    printf 'terrain: %s\n         %s\n' "$1" "$2" >&2
}
