#!/usr/bin/env bash
# Makes sure that there is a Vulkan loader and at least one driver on Linux; elsewhere the system
# brings its own graphics interface. Mesa's package holds a software driver, so it always helps.
set -euo pipefail
source "$(dirname "$0")/packages.sh"

# Whether any driver has announced itself, in the places where the Vulkan loader looks.
has_driver() {
    local named=${VK_DRIVER_FILES:-${VK_ICD_FILENAMES:-}}
    local -a paths
    if [[ -n $named ]]; then
        IFS=: read -ra paths <<<"$named"
    else
        local data_folders="${XDG_CONFIG_HOME:-$HOME/.config}:${XDG_CONFIG_DIRS:-/etc/xdg}:/etc"
        data_folders+=":${XDG_DATA_HOME:-$HOME/.local/share}"
        data_folders+=":${XDG_DATA_DIRS:-/usr/local/share:/usr/share}"
        IFS=: read -ra paths <<<"$data_folders"
        paths=("${paths[@]/%//vulkan/icd.d}")
    fi
    local path
    for path in "${paths[@]}"; do
        [[ -f $path ]] && return 0
        compgen -G "$path/*.json" >/dev/null && return 0
    done
    return 1
}

[[ $(uname -s) == Linux ]] || exit 0
if ! has_driver || ! has_library libvulkan.so.1; then
    install_packages "no Vulkan driver." mesa-vulkan-drivers libvulkan1
fi
