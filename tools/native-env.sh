# Sourced before cargo. Makes sure that bindgen finds libclang: the system's, or Debian's package
# when we are root, or the wheel from PyPI in .venv otherwise. Does nothing when all is there.

any_exists() {
    for path in "$@"; do
        [ -e "$path" ] && return 0
    done
    return 1
}

libclang_is_usable() {
    [ -n "${LIBCLANG_PATH:-}" ] && return 0
    # libclang-cpp is another library. And libclang alone is not enough: bindgen also needs clang's
    # own headers.
    any_exists /usr/lib/llvm-*/lib/libclang.so* /usr/lib/llvm-*/lib/libclang-[0-9]*.so* \
        /usr/lib/*/libclang-[0-9]*.so* /usr/lib/*/libclang.so* /usr/lib64/libclang.so* &&
        any_exists /usr/lib/llvm-*/lib/clang/*/include/stddef.h \
            /usr/lib/clang/*/include/stddef.h /usr/lib64/clang/*/include/stddef.h
}

install_libclang_with_apt() {
    [ "$(id -u)" = 0 ] && command -v apt-get >/dev/null || return 1
    echo "struna: installing libclang-dev with apt-get (once)" >&2
    { apt-get update -qq &&
        DEBIAN_FRONTEND=noninteractive apt-get install -y -qq --no-install-recommends libclang-dev
    } >/dev/null 2>&1
}

use_libclang_of_pypi() {
    sh tools/python-env.sh || return 1
    if ! .venv/bin/python -c 'import clang.native' 2>/dev/null; then
        echo "struna: installing libclang from PyPI into .venv (once)" >&2
        .venv/bin/pip install --quiet libclang==18.1.1 || return 1
    fi
    LIBCLANG_PATH=$(.venv/bin/python -c 'import clang.native as n; print(list(n.__path__)[0])') ||
        return 1
    # The wheel carries no headers of its own; gcc's serve.
    BINDGEN_EXTRA_CLANG_ARGS="-I$(gcc -print-file-name=include)"
    export LIBCLANG_PATH BINDGEN_EXTRA_CLANG_ARGS
}

if ! libclang_is_usable; then
    if ! { install_libclang_with_apt && libclang_is_usable; } && ! use_libclang_of_pypi; then
        echo "struna: libclang is missing and could not be installed; install Debian's" \
            "libclang-dev (or your system's equivalent) and try again" >&2
        exit 1
    fi
fi
