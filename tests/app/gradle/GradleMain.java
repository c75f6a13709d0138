package org.gradle.launcher;

/** Takes the place of Gradle in a distribution that tests/app/gradle/run makes: says what it was asked. */
public class GradleMain {
  public static void main(String[] arguments) {
    System.out.println("played Gradle: " + String.join(" ", arguments));
  }
}
