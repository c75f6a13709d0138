import com.github.unidbg.AndroidEmulator;
import com.github.unidbg.arm.backend.Unicorn2Factory;
import com.github.unidbg.linux.android.AndroidEmulatorBuilder;
import com.github.unidbg.linux.android.AndroidResolver;
import com.github.unidbg.linux.android.dvm.DalvikModule;
import com.github.unidbg.linux.android.dvm.VM;
import com.github.unidbg.memory.Memory;
import com.github.unidbg.memory.MemoryBlock;
import java.io.File;
import java.nio.file.Files;
import java.nio.file.Path;

/**
 * An emulated 64-bit ARM with the libraries of Android 6 loads the app's library straight from the APK
 * and tests itself with each scene. Prints a line of JSON a scene. Arguments: APK SCENE...
 */
public class RunSelfTest {
  private static final int ROOM = 2000;

  public static void main(String[] arguments) throws Exception {
    AndroidEmulator emulator =
        AndroidEmulatorBuilder.for64Bit()
            .setProcessName("org.fluxgs.app")
            .addBackendFactory(new Unicorn2Factory(false))
            .build();
    Memory memory = emulator.getMemory();
    memory.setLibraryResolver(new AndroidResolver(23));
    emulator.getSyscallHandler().setEnableThreadDispatcher(true);
    VM machine = emulator.createDalvikVM(new File(arguments[0]));
    DalvikModule library = machine.loadLibrary("fluxgs_app", true);
    MemoryBlock json = memory.malloc(ROOM, true);
    for (int i = 1; i < arguments.length; ++i) {
      byte[] bytes = Files.readAllBytes(Path.of(arguments[i]));
      MemoryBlock scene = memory.malloc(Math.max(bytes.length, 1), true);
      scene.getPointer().write(0, bytes, 0, bytes.length);
      library
          .getModule()
          .callFunction(
              emulator, "fluxgs_self_test", scene.getPointer(), bytes.length, json.getPointer(), ROOM);
      System.out.println(json.getPointer().getString(0));
      scene.free();
    }
    System.out.flush();
    Runtime.getRuntime().halt(0);
  }
}
