import java.io.File;
import java.io.FileInputStream;
import java.io.InputStream;
import java.util.HashSet;
import java.util.List;
import java.util.Set;
import org.codehaus.mojo.animal_sniffer.ClassListBuilder;
import org.codehaus.mojo.animal_sniffer.SignatureChecker;
import org.codehaus.mojo.animal_sniffer.logging.Logger;

/**
 * Whether classes use only what the oldest Android has: a list of what that is (SIGNATURE) against the
 * classes of a folder. Methods with @TargetApi say themselves that they are called on newer ones only.
 * Arguments: SIGNATURE CLASSES.
 */
public class CheckApi {
  private static final Set<String> found = new HashSet<>();

  private static final Logger LOGGER =
      new Logger() {
        public void info(String text) {}

        public void info(String text, Throwable problem) {}

        public void debug(String text) {}

        public void debug(String text, Throwable problem) {}

        public void warn(String text) {}

        public void warn(String text, Throwable problem) {}

        public void error(String text) {
          if (found.add(text)) System.err.println(text);
        }

        public void error(String text, Throwable problem) {
          error(text);
        }
      };

  public static void main(String[] arguments) throws Exception {
    File classes = new File(arguments[1]);
    ClassListBuilder own = new ClassListBuilder(LOGGER);
    own.process(classes);
    Set<String> ignored = new HashSet<>(own.getPackages());
    ignored.add("kotlin.*");
    ignored.add("org.jetbrains.annotations.*");
    try (InputStream signature = new FileInputStream(arguments[0])) {
      SignatureChecker checker = new SignatureChecker(signature, ignored, LOGGER);
      checker.setSourcePath(List.of());
      checker.setAnnotationTypes(List.of("android.annotation.TargetApi"));
      checker.process(classes);
    }
    System.out.println(found.size() + " uses of what the oldest Android does not have");
    if (!found.isEmpty()) System.exit(1);
  }
}
