import com.android.apksig.ApkSigner;
import java.io.File;
import java.io.FileInputStream;
import java.security.KeyStore;
import java.security.PrivateKey;
import java.security.cert.X509Certificate;
import java.util.ArrayList;
import java.util.List;

/**
 * Signs an APK (schemes 2 and 3) and aligns what is stored: everything to 4 bytes, libraries to 16 KB
 * pages. Arguments: IN OUT KEYSTORE ALIAS MIN_SDK; the password is in the variable FLUXGS_KEY_PASSWORD.
 */
@SuppressWarnings("deprecation") // the newer way wants keys of several kinds
public class SignApk {
  public static void main(String[] arguments) throws Exception {
    char[] password = System.getenv("FLUXGS_KEY_PASSWORD").toCharArray();
    KeyStore store = KeyStore.getInstance("PKCS12");
    try (FileInputStream stream = new FileInputStream(arguments[2])) {
      store.load(stream, password);
    }
    String alias = arguments[3];
    if (!store.isKeyEntry(alias)) throw new IllegalArgumentException("no key '" + alias + "'");
    List<X509Certificate> certificates = new ArrayList<>();
    for (var certificate : store.getCertificateChain(alias))
      certificates.add((X509Certificate) certificate);
    var signer =
        new ApkSigner.SignerConfig.Builder(
                alias, (PrivateKey) store.getKey(alias, password), certificates)
            .build();
    new ApkSigner.Builder(List.of(signer))
        .setInputApk(new File(arguments[0]))
        .setOutputApk(new File(arguments[1]))
        .setMinSdkVersion(Integer.parseInt(arguments[4]))
        .setV1SigningEnabled(false)
        .setV2SigningEnabled(true)
        .setV3SigningEnabled(true)
        .setAlignFileSize(false)
        .setLibraryPageAlignmentBytes(16384)
        .build()
        .sign();
  }
}
