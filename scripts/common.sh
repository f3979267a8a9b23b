# Sourced by the other scripts: starts them in the clone, with the same surroundings everywhere.
unset CDPATH PYTHONPATH PYTHONHOME PYTHONDONTWRITEBYTECODE
cd "$(dirname "${BASH_SOURCE[0]}")/.."
export PATH="$PWD/.venv/bin:$PATH" PIP_DISABLE_PIP_VERSION_CHECK=1 MPLBACKEND=Agg
exec </dev/null
mkdir -p build/log
# The release build: library, Python extension, executable and test programs of one compilation (meson.build).
release=build/release
# Of the debug build by fpm: bounds, pointers and shapes checked, signalling NaN in what is not set, a stop at the first invalid
# operation.
debug_checks='-Og -g1 -fbacktrace -fcheck=all,no-array-temps -finit-real=snan -ffpe-trap=invalid,zero'
# Warnings are errors, but for those that right code cannot avoid: an override that ignores an argument, an index that an
# if guards, the bounds of an allocatable array that has not been allocated. Given without --profile, or its flags would come last.
debug_flags="$debug_checks -Werror -std=f2018 -Wall -Wextra -Wimplicit-interface -Wimplicit-procedure"
debug_flags="$debug_flags -Wno-unused-dummy-argument -Wno-do-subscript -Wno-compare-reals -Wno-maybe-uninitialized -Wno-uninitialized"

# log_of TITLE: where the log of a step or a test part goes.
log_of() {
   echo "build/log/$(tr -cs 'a-z0-9' '-' <<<"${1,,}" | sed 's/-*$//').log"
}

# show_failures LOG: what failed by the log, then its end, set off from what the scripts say themselves.
show_failures() {
   echo "--- $1:"
   { grep -aE '^(FAILED|ERROR|E:)|: WARNING: ' "$1" | head -n 40; echo ...; tail -n 30 "$1"; } | sed 's/^/    /' || true
}

# step MESSAGE COMMAND...: one line when the command works, also the tail of its log when it does not.
step() {
   local message=$1 start=$SECONDS log status=0
   log=$(log_of "$message")
   shift
   printf '%-58s ' "$message"
   "$@" >"$log" 2>&1 || status=$?
   if [ "$status" -eq 0 ]; then
      echo "done, $((SECONDS - start)) s"
   else
      echo "FAILED (exit status $status)"
      show_failures "$log"
   fi
   return "$status"
}

# counts LOG: the sums of passed and of failed over the closing lines of our own test programs and of pytest.
counts() {
   grep -aE '^[0-9]+ (passed|failed|errors?)\b' "$1" | grep -oE '[0-9]+ (passed|failed|error)' |
      awk '{ n[$2] += $1 } END { print n["passed"] + 0, n["failed"] + n["error"] + 0 }' || echo 0 0
}

# suites PROGRAM ARGUMENT...: the suites of a test program on all cores, each in a process of its own; the last are the longest.
suites() {
   "$1" --suites | tac | xargs -P "$(nproc)" -I{} "$1" {} "${@:2}"
}

# debug_program NAME: where fpm puts a test program of the debug build.
debug_program() {
   fpm test "$1" --flag "$debug_flags" --runner echo 2>build/log/debug-program.log | tail -n 1
}

# once STAMP HASH COMMAND...: runs the command unless it was done for the same hash.
once() {
   local stamp=.venv/$1 hash=$2
   shift 2
   [ "$(cat "$stamp" 2>/dev/null)" = "$hash" ] && return
   "$@"
   echo "$hash" >"$stamp"
}

hash_files() {
   find "$@" -type f ! -name '*.pyc' -print0 | LC_ALL=C sort -z | xargs -0 sha256sum | sha256sum
}

# pythons: every Python from 3.10 on that this machine offers, the first found of each version.
pythons() {
   local minor path
   for minor in 10 11 12 13 14 15; do
      for path in "$(command -v "python3.$minor" || true)" "${PYENV_ROOT:-$HOME/.pyenv}"/versions/3."$minor".*/bin/python \
                  /opt/python/cp3"$minor"-cp3"$minor"/bin/python; do
         [ -x "$path" ] && "$path" -c 'import sys; assert sys.version_info[1] == '"$minor" 2>/dev/null && echo "$path" && break
      done
   done
}
