# Set-up that examples/quickstart and tests/run share: messages, packages, one build of one preset. Sourced, not run.
# Both scripts begin with `set -euo pipefail`.

project_root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)

# What the library, the plugins and the tool are built with. Names are those of Debian 12.
build_packages=(build-essential cmake ninja-build libeigen3-dev libsundials-dev libboost-dev libfmt-dev
  libtomlplusplus-dev libcli11-dev nlohmann-json3-dev libpugixml-dev zlib1g-dev libjs-three libjs-dygraphs)
# What the tests, the benchmark program and the checks of the sources need on top (libomp-dev: clang-tidy reads omp.h;
# libmpfr-dev: exact values of functions; libfuzzylite-dev: the oracle of fuzzy rules; gmsh: makes meshes; chromium: opens the pages that
# are written; python3-numpy: reads binary files as users do).
test_packages=(doctest-dev libbenchmark-dev libmpfr-dev libfuzzylite-dev clang-format clang-tidy libomp-dev gmsh chromium
  python3-numpy)
# What tests/fuzz needs on top of the first: Clang, libFuzzer and the sanitizers, names for traces of calls, OpenMP for Clang.
fuzz_packages=(clang libclang-rt-14-dev llvm libomp-dev)

say() { printf '== %s\n' "$*"; }

# fail WHAT [LINE …]: ends the script with status 1; the lines say what to do.
fail() {
  printf '\nerror: %s\n' "$1" >&2
  shift
  (($# == 0)) || printf '  %s\n' "$@" >&2
  exit 1
}

# logged FILE WHAT COMMAND …: runs the command with its output in FILE; on failure shows the file's end and stops.
logged() {
  local log=$1 what=$2
  shift 2
  rm -f "$log" # it may be another user's
  if ! "$@" >"$log" 2>&1 </dev/null; then
    tail -n 30 "$log" >&2
    fail "$what failed." "Above are the last lines of $log."
  fi
}

# make_folder FOLDER …: creates the folders, or ends with a message of our own.
make_folder() {
  local folder
  for folder in "$@"; do
    mkdir -p "$folder" 2>/dev/null && [[ -w $folder ]] ||
      fail "cannot write to $folder" "Copy the project to a folder where you can write, and start the script there."
  done
}

is_installed() { [[ $(dpkg-query --show --showformat='${db:Status-Status}' "$1" 2>/dev/null) == installed ]]; }

# watched LOG COMMAND …: runs the command with its output appended to LOG, and reports the progress of apt-get meanwhile: on a
# terminal in one line that changes, elsewhere in a line every five seconds.
watched() {
  local log=$1 watcher status=0
  shift
  # The command is in the foreground, so that Ctrl-C reaches it; the watcher ends with this shell.
  (
    text="" last="" tick=0
    while kill -0 $$ 2>/dev/null; do
      sleep 0.5
      [[ -t 1 ]] || ((++tick % 10 == 0)) || continue
      text=$(apt_progress "$log")
      [[ $text != "$last" ]] || continue
      last=$text
      if [[ -t 1 ]]; then printf '\r\033[K   %s' "$text"; else printf '   %s\n' "$text"; fi
    done
  ) &
  watcher=$!
  "$@" >>"$log" 2>&1 </dev/null || status=$?
  kill "$watcher" 2>/dev/null || true
  wait "$watcher" 2>/dev/null || true
  [[ ! -t 1 ]] || printf '\r\033[K'
  return "$status"
}

# apt_progress LOG: "packages: 12 of 34 fetched", then unpacked, then set up, according to the log.
apt_progress() {
  awk '
    / newly installed, / { total = $1 + $3; fetched = 0 }   # "3 upgraded, 31 newly installed, …"
    /^Get:/ { fetched++ }
    /^Unpacking / { unpacked++ }
    /^Setting up / { ready++ }
    END {
      if (!total) print "lists of packages: " fetched + 0 " fetched"
      else if (ready) print "packages: " ready " of " total " set up"
      else if (unpacked) print "packages: " unpacked " of " total " unpacked"
      else print "packages: " fetched + 0 " of " total " fetched"
    }' "$1"
}

# need_packages NAME …: installs those that are missing. If none is, it does nothing and needs neither network nor rights.
need_packages() {
  local name missing=() as_root=() log
  command -v dpkg-query >/dev/null && command -v apt-get >/dev/null ||
    fail "this machine has no apt-get, which this script needs to install Debian packages." \
      "Install the equivalents of these packages:" "  $*" "and build the project by:" \
      "  cmake --preset release -DSPRINGNET_BUILD_TESTS=OFF && cmake --build --preset release"
  for name in "$@"; do
    is_installed "$name" || missing+=("$name")
  done
  ((${#missing[@]})) || return 0

  if ((EUID != 0)); then
    command -v sudo >/dev/null ||
      fail "packages are missing, installing them needs root, and there is no sudo." "Run as root:" \
        "  apt-get install ${missing[*]}" "and start this script again."
    as_root=(sudo)
    # Without a terminal nobody could type a password: better an error than a script that hangs.
    [[ -t 0 ]] || as_root+=(--non-interactive)
    "${as_root[@]}" true ||
      fail "packages are missing, and sudo does not let you install them." "Ask an administrator to run:" \
        "  apt-get install ${missing[*]}" "and start this script again."
  fi
  as_root+=(env DEBIAN_FRONTEND=noninteractive)

  log=$project_root/build/apt.log
  rm -f "$log"
  say "installing missing packages (log: $log): ${missing[*]}"
  # A list of packages that cannot be updated is no error yet: the existing one may suffice.
  : >"$log"
  watched "$log" "${as_root[@]}" apt-get update || true
  if ! watched "$log" "${as_root[@]}" apt-get install --yes --no-install-recommends "${missing[@]}"; then
    grep -E '^(E|Err|W):' "$log" | tail -n 12 >&2 || true
    fail "apt-get could not install the missing packages (whole log: $log)." \
      "If it could not reach its servers, check the network. If it does not know a package: this script is made for" \
      "Debian 12 with the 'main' component."
  fi
}

# Number of parallel compilers: one per core, as far as there are 1.5 GiB of memory for each.
build_jobs() {
  local cores memory
  cores=$(nproc)
  memory=$(awk '/^MemAvailable:/ {print int($2 / 1572864)}' /proc/meminfo)
  ((memory < cores)) && cores=$((memory > 0 ? memory : 1))
  echo "$cores"
}

# configure PRESET [CMAKE_OPTION …]
configure() {
  local preset=$1 folder=$project_root/build/$1 home
  shift
  make_folder "$folder"
  if [[ -f $folder/CMakeCache.txt ]]; then
    home=$(sed -n 's/^CMAKE_HOME_DIRECTORY:INTERNAL=//p' "$folder/CMakeCache.txt")
    [[ $home == "$project_root" ]] ||
      fail "$folder belongs to the sources in $home, not to these." "Remove that folder and start again."
  fi
  logged "$folder/configure.log" "configuring $preset" cmake -S "$project_root" --preset "$preset" "$@"
}

# build PRESET: everything in it.
build() {
  (cd "$project_root" && cmake --build --preset "$1" --parallel "$(build_jobs)") ||
    fail "the build of the preset $1 failed; its messages are above."
}
