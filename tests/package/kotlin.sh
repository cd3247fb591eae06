#!/usr/bin/env bash
# The Kotlin classes, on this machine's Java: kotlin_demo.kt passes, and says when the hash is another one.
#   kotlin.sh FOLDER_OF_THE_CLASSES WEB_SCENE HASH_FILE OUTPUT_FOLDER
set -euo pipefail
here=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
classes=$1 web_scene=$2 hashes=$3 output=$4
mkdir -p "$output"
"$web_scene" demo "$output/demo.json"
JAVA_OPTS="-Xmx1g -XX:TieredStopAtLevel=1" kotlinc -nowarn -cp "$classes/classes.jar" "$here/kotlin_demo.kt" -d "$output/demo.jar"
# The clock of the golden hash: each reading is so many nanoseconds later.
jdk=$(dirname "$(dirname "$(readlink -f "$(command -v javac)")")")
printf '%s\n' '#include <jni.h>' 'static jlong reading, step;' 'static jlong now(void* user) { return (void)user, reading += step; }' \
  'jlong Java_Demo_clock(JNIEnv* env, jclass demo, jlong of) { return (void)env, (void)demo, step = of, (jlong)now; }' |
  cc -shared -fPIC -I "$jdk/include" -I "$jdk/include/linux" -x c - -o "$output/libclock.so"
demo() {
  java -Xcheck:jni -Djava.library.path="$classes:$output" -cp "$classes/classes.jar:$output/demo.jar:/usr/share/java/kotlin-stdlib.jar" \
    Demo "$output/demo.json" "$hashes" "$@" 2>&1
}
demo 90 | tee "$output/log"
if grep -q WARNING "$output/log"; then echo "JNI is used wrongly"; exit 1; fi
# The control: another friction, so another hash.
if control=$(demo 30 0.5) || ! grep -q "differs from the golden one" <<<"$control"; then echo "another hash was accepted: $control"; exit 1; fi
