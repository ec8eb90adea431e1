#!/usr/bin/env bash
# use_elsewhere.sh CMAKE BUILD_FOLDER SOURCE_FOLDER COMPILER SCRATCH_FOLDER
set -euo pipefail
cmake=$1 build=$2 source=$3 compiler=$4 scratch=$5
fail() { echo "FAILED: $*"; exit 1; }

rm -rf "$scratch/prefix" "$scratch/example" "$scratch/wrench"
"$cmake" --install "$build" --prefix "$scratch/prefix" --component development >/dev/null
# The example is copied, so that it cannot find anything of the source tree beside it.
mkdir -p "$scratch/example"
cp "$source"/examples/wrench/* "$scratch/example"
"$cmake" -S "$scratch/example" -B "$scratch/wrench" -G Ninja -DCMAKE_CXX_COMPILER="$compiler" -DCMAKE_BUILD_TYPE=Release \
  -DCMAKE_PREFIX_PATH="$scratch/prefix"
"$cmake" --build "$scratch/wrench"
if grep -rqF "$source" "$scratch/prefix/lib" --include='*.cmake'; then fail "the installed package names the source tree"; fi

# A device in C needs one header of the package.
cp "$source/examples/device/own_device.c" "$scratch/example"
cc -O2 -Wall -Wextra -Werror -shared -fPIC -I "$scratch/prefix/include/vr_oos" "$scratch/example/own_device.c" -o "$scratch/own_device.so" -lm ||
  fail "a device in C cannot be compiled against the package"

# The plate's top is z = 0. A ball of 10 mm that is 1 mm deep is pushed straight up; 5 mm above, the force is zero.
export VR_OOS_CACHE=$scratch/cooked
meshes=$source/scenarios/touch/meshes
deep=$("$scratch/wrench/wrench" "$meshes/ball.obj" "$meshes/plate.obj" 0 0 0.009)
apart=$("$scratch/wrench/wrench" "$meshes/ball.obj" "$meshes/plate.obj" 0 0 0.015)
echo "$deep"
awk '/^force_N/ { found = 1; ok = $4 > 0.1 && $2 * $2 + $3 * $3 < 0.01 * $4 * $4 } END { exit !(found && ok) }' <<<"$deep" ||
  fail "the ball is not pushed straight up out of the plate: $deep"
[ "$(head -1 <<<"$apart")" = "force_N 0 0 0" ] || fail "a force without contact: $apart"
