@echo off
rem Builds the app with the Gradle that gradle\wrapper\gradle-wrapper.properties names; it is fetched
rem the first time. Needs Java 17 or newer: JAVA_HOME, or on the PATH.
setlocal
set "JAVA=java"
if defined JAVA_HOME set "JAVA=%JAVA_HOME%\bin\java.exe"
"%JAVA%" -Xmx64m -Dorg.gradle.appname=gradlew -classpath "%~dp0gradle\wrapper\gradle-wrapper.jar" org.gradle.wrapper.GradleWrapperMain %*
exit /b %ERRORLEVEL%
