import java.io.File;
import java.io.IOException;
import java.nio.file.Files;
import java.nio.file.Path;
import java.util.HashMap;
import java.util.List;
import java.util.Map;
import java.util.TreeMap;
import java.util.TreeSet;
import java.util.Set;
import java.util.regex.Matcher;
import java.util.regex.Pattern;
import org.gradle.api.Project;
import org.gradle.api.internal.project.ProjectInternal;
import org.gradle.testfixtures.ProjectBuilder;

/**
 * Android's own plugin configures app/build.gradle, without Gradle and without an SDK, and says what
 * came out: a line "name value" each, in the file `facts` of the project's folder; where it does not take
 * the file, one line a cause. Arguments: the folder of the project (a copy: it is written to), and
 * properties NAME=VALUE of the command line; "--" before the next project.
 */
public class ConfigureProject {
  public static void main(String[] arguments) throws IOException {
    for (String project : String.join("\n", arguments).split("\n--\n")) {
      String[] words = project.split("\n");
      Path facts = Path.of(words[0], "facts");
      try {
        Files.writeString(facts, configure(words));
      } catch (Throwable problem) {
        StringBuilder said = new StringBuilder();
        for (Throwable cause = problem; cause != null; cause = cause.getCause())
          said.append("error " + cause.getClass().getSimpleName() + ": " + cause.getMessage() + "\n");
        Files.writeString(facts, said);
      }
    }
    System.out.flush();
    Runtime.getRuntime().halt(0); // threads of Gradle would stay
  }

  private static String configure(String[] arguments) throws Exception {
    File folder = new File(arguments[0]);
    Project root =
        ProjectBuilder.builder()
            .withProjectDir(folder)
            .withGradleUserHomeDir(new File(folder, "home"))
            .withName("root")
            .build();
    File app = new File(folder, "app");
    Project project =
        ProjectBuilder.builder().withParent(root).withProjectDir(app).withName("app").build();
    for (int i = 1; i < arguments.length; ++i) {
      String[] pair = arguments[i].split("=", 2);
      project.getExtensions().getExtraProperties().set(pair[0], pair[1]);
    }
    project.getExtensions().getExtraProperties().set("libs", libraries(folder.toPath()));
    // What the file's block `plugins` asks for; a block is only for Gradle's own start
    project.getPluginManager().apply("com.android.application");
    project.getPluginManager().apply("org.jetbrains.kotlin.android");
    Path script = app.toPath().resolve("build.gradle");
    Path body = app.toPath().resolve("body.gradle");
    Files.writeString(body, Files.readString(script).replaceFirst("(?s)^plugins \\{.*?\n}", "\n\n\n"));
    Files.writeString(script, ""); // evaluate() runs it
    project.apply(Map.of("from", body.toFile()));
    ((ProjectInternal) project).evaluate();
    return report(project);
  }

  /** The libraries of the version catalogue as a build file writes them: libs.some.library. */
  private static Map<String, Object> libraries(Path folder) throws IOException {
    String text = Files.readString(folder.resolve("gradle/libs.versions.toml"));
    Map<String, String> versions = new HashMap<>();
    Matcher version = Pattern.compile("(?m)^([\\w-]+) = \"([^\"]+)\"$").matcher(text);
    while (version.find()) versions.put(version.group(1), version.group(2));
    Map<String, Object> all = new HashMap<>();
    Matcher library =
        Pattern.compile("(?m)^([\\w-]+) = \\{ module = \"([^\"]+)\", version.ref = \"([^\"]+)\"")
            .matcher(text);
    while (library.find()) {
      Map<String, Object> at = all;
      List<String> names = List.of(library.group(1).split("-"));
      for (String name : names.subList(0, names.size() - 1)) at = inside(at, name);
      String found = versions.get(library.group(3));
      if (found == null) throw new IOException("no version " + library.group(3));
      at.put(names.get(names.size() - 1), library.group(2) + ":" + found);
    }
    return all;
  }

  @SuppressWarnings("unchecked")
  private static Map<String, Object> inside(Map<String, Object> map, String name) {
    return (Map<String, Object>) map.computeIfAbsent(name, unused -> new HashMap<String, Object>());
  }

  private static String report(Project project) {
    var android =
        (com.android.build.gradle.internal.dsl.BaseAppModuleExtension)
            project.getExtensions().getByName("android");
    var defaults = android.getDefaultConfig();
    var release = android.getBuildTypes().getByName("release");
    Map<String, Object> facts = new TreeMap<>();
    facts.put("namespace", android.getNamespace());
    facts.put("id", defaults.getApplicationId());
    facts.put("compile-sdk", android.getCompileSdk());
    facts.put("min-sdk", defaults.getMinSdk());
    facts.put("target-sdk", defaults.getTargetSdk());
    facts.put("version", defaults.getVersionName());
    facts.put("version-code", defaults.getVersionCode());
    facts.put("abis", new TreeSet<>(defaults.getNdk().getAbiFilters()));
    facts.put("ndk", android.getNdkVersion());
    facts.put("cmake", android.getExternalNativeBuild().getCmake().getPath());
    facts.put("cmake-version", android.getExternalNativeBuild().getCmake().getVersion());
    facts.put("cmake-arguments", defaults.getExternalNativeBuild().getCmake().getArguments());
    facts.put("minify", release.isMinifyEnabled());
    facts.put("signing", release.getSigningConfig() == null ? "none" : release.getSigningConfig().getName());
    facts.put("dependencies", dependencies(project));
    for (String set : List.of("main", "debug", "release", "offline", "net"))
      facts.put("manifest-" + set, android.getSourceSets().getByName(set).getManifest().getSrcFile());
    android.getProductFlavors().forEach(
        it -> facts.put("flavour-" + it.getName(), it.isDefault() + " " + it.getVersionNameSuffix()));
    Set<String> tasks = new TreeSet<>();
    project.getTasks().forEach(task -> tasks.add(task.getName()));
    facts.put("tasks", tasks.size());
    for (String task : List.of("assembleRelease", "minifyOfflineReleaseWithR8", "compileNetReleaseKotlin"))
      facts.put("has-" + task, tasks.contains(task));
    StringBuilder lines = new StringBuilder();
    facts.forEach((name, value) -> lines.append(name + " " + value + "\n"));
    return lines.toString();
  }

  private static Set<String> dependencies(Project project) {
    Set<String> all = new TreeSet<>();
    project
        .getConfigurations()
        .getByName("implementation")
        .getDependencies()
        .forEach(it -> all.add(it.getGroup() + ":" + it.getName() + ":" + it.getVersion()));
    return all;
  }
}
