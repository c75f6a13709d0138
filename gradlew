#!/bin/sh
# Builds the app with the Gradle that gradle/wrapper/gradle-wrapper.properties names; it is fetched the
# first time. Needs Java 17 or newer: JAVA_HOME, or on the PATH.
set -eu
wrapper=$(cd -- "$(dirname -- "$0")" && pwd)/gradle/wrapper/gradle-wrapper.jar
java=${JAVA_HOME:+$JAVA_HOME/bin/}java
if ! command -v "$java" > /dev/null; then
  echo "gradlew: error: there is no $java: install a JDK 17 or set JAVA_HOME" >&2
  exit 1
fi
exec "$java" -Xmx64m -Dorg.gradle.appname=gradlew -classpath "$wrapper" \
  org.gradle.wrapper.GradleWrapperMain "$@"
