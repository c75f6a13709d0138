// What the page says, in the languages of the app and two more. Errors about files stay in English: they name
// bytes and fields, and are the same on every platform.

const en = {
  open: 'Open a scene', reset: 'Back to the start', turn: 'Auto-orbit', walk: 'Walk', flip: 'Turn upside down', save: 'Keep this view',
  kept: 'Kept views', view: 'View {0}', forget: 'Forget view {0}', fullscreen: 'Full screen', picture: 'Save a picture',
  link: 'Copy a link to this view', copied: 'The link is copied.', settings: 'Settings', help: 'Help', statistics: 'Statistics',
  close: 'Close', cancel: 'Cancel', quality: 'Quality', automatic: 'Automatic', sharp: 'Sharp', fast: 'Fast',
  splats: 'Splats at most', all: 'all', harmonics: 'Spherical harmonics, degree', background: 'Background',
  scene: 'Scene: drag to turn, two fingers or the right button to move, pinch or wheel to zoom, W A S D to fly',
  drop: 'Drop a scene here, or open one', reading: 'Loading {0}', decoding: 'Unpacking {0}', left: '{0} s left',
  memory: 'There is not enough memory for this scene.', network: 'The scene cannot be fetched.',
  read: 'Not all of the scene came.', damaged: 'This is no scene, or it is damaged.',
  start: 'The viewer cannot start.', files: 'This scene has several files: choose all of them together.',
  webgl: 'This browser has no WebGL 2, with which scenes are drawn. A newer one has.',
  lost: 'The graphics card is being restored …', reduced: 'Of {1} splats {0} are shown: there is no room for more.',
  helpTouch: 'One finger turns the scene, two move it, pinch to zoom, twist to roll. Double-tap something to look at it.',
  helpMouse: 'Drag with the left button to turn, with the right one to move; the wheel zooms; double-click to look at something.',
  helpKeys: 'W A S D or arrows fly, Q E down and up, + − faster and slower; O auto-orbit, F upside down, R back to the start.',
};
const de = {
  open: 'Szene öffnen', reset: 'Zurück zum Anfang', turn: 'Langsam drehen', walk: 'Gehen', flip: 'Auf den Kopf stellen', save: 'Diese Ansicht merken',
  kept: 'Gemerkte Ansichten', view: 'Ansicht {0}', forget: 'Ansicht {0} vergessen', fullscreen: 'Vollbild', picture: 'Bild speichern',
  link: 'Link zu dieser Ansicht kopieren', copied: 'Der Link ist kopiert.', settings: 'Einstellungen', help: 'Hilfe', statistics: 'Statistik',
  close: 'Schließen', cancel: 'Abbrechen', quality: 'Qualität', automatic: 'Automatisch', sharp: 'Scharf', fast: 'Schnell',
  splats: 'Höchstens so viele Splats', all: 'alle', harmonics: 'Kugelfunktionen, Grad', background: 'Hintergrund',
  scene: 'Szene: ziehen dreht, zwei Finger oder die rechte Taste verschieben, Rad oder zwei Finger zoomen, W A S D fliegen',
  drop: 'Szene hier ablegen oder öffnen', reading: '{0} wird geladen', decoding: '{0} wird entpackt', left: 'noch {0} s',
  memory: 'Für diese Szene reicht der Speicher nicht.', network: 'Die Szene lässt sich nicht laden.',
  read: 'Die Szene kam nicht vollständig an.', damaged: 'Das ist keine Szene, oder sie ist beschädigt.',
  start: 'Der Betrachter kann nicht starten.', files: 'Diese Szene hat mehrere Dateien: bitte alle zusammen auswählen.',
  webgl: 'Diesem Browser fehlt WebGL 2, womit Szenen gezeichnet werden. Ein neuerer hat es.',
  lost: 'Die Grafikkarte wird wiederhergestellt …', reduced: 'Gezeigt werden {0} von {1} Splats: für mehr ist kein Platz.',
  helpTouch: 'Ein Finger dreht die Szene, zwei verschieben, zoomen und rollen sie. Doppelt tippen, um etwas anzusehen.',
  helpMouse: 'Linke Taste dreht, rechte verschiebt, das Rad zoomt; Doppelklick sieht etwas an.',
  helpKeys: 'W A S D oder Pfeile fliegen, Q E ab und auf, + − schneller und langsamer; O drehen, F auf den Kopf, R zum Anfang.',
};
const fr = {
  open: 'Ouvrir une scène', reset: 'Retour au départ', turn: 'Rotation automatique', walk: 'Marcher', flip: 'Retourner', save: 'Garder cette vue',
  kept: 'Vues gardées', view: 'Vue {0}', forget: 'Oublier la vue {0}', fullscreen: 'Plein écran', picture: 'Enregistrer une image',
  link: 'Copier un lien vers cette vue', copied: 'Le lien est copié.', settings: 'Réglages', help: 'Aide', statistics: 'Statistiques',
  close: 'Fermer', cancel: 'Annuler', quality: 'Qualité', automatic: 'Automatique', sharp: 'Nette', fast: 'Rapide',
  splats: 'Splats au plus', all: 'tous', harmonics: 'Harmoniques sphériques, degré', background: 'Arrière-plan',
  scene: 'Scène : glisser pour tourner, deux doigts ou bouton droit pour déplacer, pincer ou molette pour zoomer, W A S D pour voler',
  drop: 'Déposez une scène ici, ou ouvrez-en une', reading: 'Chargement de {0}', decoding: 'Décodage de {0}', left: 'encore {0} s',
  memory: 'La mémoire ne suffit pas pour cette scène.', network: 'La scène ne peut pas être téléchargée.',
  read: 'La scène n’est pas arrivée en entier.', damaged: 'Ce n’est pas une scène, ou elle est endommagée.',
  start: 'La visionneuse ne peut pas démarrer.', files: 'Cette scène a plusieurs fichiers : choisissez-les tous ensemble.',
  webgl: 'Ce navigateur n’a pas WebGL 2, nécessaire pour dessiner. Un plus récent l’a.',
  lost: 'La carte graphique est en cours de restauration…', reduced: '{0} splats sur {1} sont affichés : il n’y a pas la place pour plus.',
  helpTouch: 'Un doigt tourne la scène, deux la déplacent, pincez pour zoomer, tournez pour incliner. Touchez deux fois pour regarder un point.',
  helpMouse: 'Bouton gauche pour tourner, droit pour déplacer, molette pour zoomer ; double-clic pour regarder un point.',
  helpKeys: 'W A S D ou flèches pour voler, Q E descendre et monter, + − vitesse ; O rotation, F retourner, R départ.',
};
const es = {
  open: 'Abrir una escena', reset: 'Volver al inicio', turn: 'Giro automático', walk: 'Caminar', flip: 'Poner del revés', save: 'Guardar esta vista',
  kept: 'Vistas guardadas', view: 'Vista {0}', forget: 'Olvidar la vista {0}', fullscreen: 'Pantalla completa', picture: 'Guardar una imagen',
  link: 'Copiar un enlace a esta vista', copied: 'El enlace está copiado.', settings: 'Ajustes', help: 'Ayuda', statistics: 'Estadísticas',
  close: 'Cerrar', cancel: 'Cancelar', quality: 'Calidad', automatic: 'Automática', sharp: 'Nítida', fast: 'Rápida',
  splats: 'Splats como máximo', all: 'todos', harmonics: 'Armónicos esféricos, grado', background: 'Fondo',
  scene: 'Escena: arrastrar gira, dos dedos o botón derecho mueven, pellizco o rueda acercan, W A S D vuelan',
  drop: 'Suelte aquí una escena o abra una', reading: 'Cargando {0}', decoding: 'Descomprimiendo {0}', left: 'quedan {0} s',
  memory: 'No hay memoria suficiente para esta escena.', network: 'No se puede descargar la escena.',
  read: 'La escena no llegó completa.', damaged: 'No es una escena, o está dañada.',
  start: 'El visor no puede iniciarse.', files: 'Esta escena tiene varios archivos: elíjalos todos juntos.',
  webgl: 'Este navegador no tiene WebGL 2, con el que se dibuja. Uno más nuevo lo tiene.',
  lost: 'Se está restaurando la tarjeta gráfica…', reduced: 'Se muestran {0} de {1} splats: no hay sitio para más.',
  helpTouch: 'Un dedo gira la escena, dos la mueven, pellizque para acercar, gire para inclinar. Toque dos veces algo para mirarlo.',
  helpMouse: 'Botón izquierdo gira, derecho mueve, la rueda acerca; doble clic mira un punto.',
  helpKeys: 'W A S D o flechas vuelan, Q E bajar y subir, + − velocidad; O giro, F del revés, R inicio.',
};
const pt = {
  open: 'Abrir uma cena', reset: 'Voltar ao início', turn: 'Rotação automática', walk: 'Caminhar', flip: 'Virar ao contrário', save: 'Guardar esta vista',
  kept: 'Vistas guardadas', view: 'Vista {0}', forget: 'Esquecer a vista {0}', fullscreen: 'Tela cheia', picture: 'Salvar uma imagem',
  link: 'Copiar um link para esta vista', copied: 'O link foi copiado.', settings: 'Definições', help: 'Ajuda', statistics: 'Estatísticas',
  close: 'Fechar', cancel: 'Cancelar', quality: 'Qualidade', automatic: 'Automática', sharp: 'Nítida', fast: 'Rápida',
  splats: 'Splats no máximo', all: 'todos', harmonics: 'Harmónicos esféricos, grau', background: 'Fundo',
  scene: 'Cena: arrastar gira, dois dedos ou botão direito movem, pinça ou roda aproximam, W A S D voam',
  drop: 'Solte uma cena aqui ou abra uma', reading: 'A carregar {0}', decoding: 'A descompactar {0}', left: 'faltam {0} s',
  memory: 'Não há memória suficiente para esta cena.', network: 'A cena não pode ser transferida.',
  read: 'A cena não chegou completa.', damaged: 'Não é uma cena, ou está danificada.',
  start: 'O visualizador não pode iniciar.', files: 'Esta cena tem vários ficheiros: escolha todos juntos.',
  webgl: 'Este navegador não tem WebGL 2, necessário para desenhar. Um mais recente tem.',
  lost: 'A placa gráfica está a ser restaurada…', reduced: 'São mostrados {0} de {1} splats: não há espaço para mais.',
  helpTouch: 'Um dedo gira a cena, dois movem-na, pinça aproxima, torção inclina. Toque duas vezes em algo para olhar.',
  helpMouse: 'Botão esquerdo gira, direito move, a roda aproxima; duplo clique olha para um ponto.',
  helpKeys: 'W A S D ou setas voam, Q E descer e subir, + − velocidade; O rotação, F ao contrário, R início.',
};
const ja = {
  open: 'シーンを開く', reset: '最初の視点に戻る', turn: '自動回転', walk: '歩く', flip: '上下を反転', save: 'この視点を保存',
  kept: '保存した視点', view: '視点 {0}', forget: '視点 {0} を削除', fullscreen: '全画面', picture: '画像を保存',
  link: 'この視点へのリンクをコピー', copied: 'リンクをコピーしました。', settings: '設定', help: 'ヘルプ', statistics: '統計',
  close: '閉じる', cancel: 'キャンセル', quality: '画質', automatic: '自動', sharp: '鮮明', fast: '高速',
  splats: 'スプラット数の上限', all: 'すべて', harmonics: '球面調和関数の次数', background: '背景',
  scene: 'シーン: ドラッグで回転、2本指または右ボタンで移動、ピンチまたはホイールで拡大、W A S D で飛行',
  drop: 'ここにシーンをドロップするか、開いてください', reading: '{0} を読み込み中', decoding: '{0} を展開中', left: '残り {0} 秒',
  memory: 'このシーンにはメモリが足りません。', network: 'シーンを取得できません。',
  read: 'シーンのすべてが届きませんでした。', damaged: 'シーンではないか、壊れています。',
  start: 'ビューアーを起動できません。', files: 'このシーンは複数のファイルからなります。すべてをまとめて選んでください。',
  webgl: 'このブラウザーには描画に必要な WebGL 2 がありません。新しいブラウザーにはあります。',
  lost: 'グラフィックスを復元しています…', reduced: '{1} 個のうち {0} 個のスプラットを表示しています。これ以上の空きがありません。',
  helpTouch: '1本指で回転、2本指で移動、ピンチで拡大、ひねって傾けます。ダブルタップした場所を見ます。',
  helpMouse: '左ボタンで回転、右ボタンで移動、ホイールで拡大、ダブルクリックした場所を見ます。',
  helpKeys: 'W A S D か矢印キーで飛行、Q E で下と上、+ − で速度、O 自動回転、F 上下反転、R 最初の視点。',
};
const zh = {
  open: '打开场景', reset: '回到起始视角', turn: '自动环绕', walk: '行走', flip: '上下翻转', save: '保存此视角',
  kept: '已保存的视角', view: '视角 {0}', forget: '删除视角 {0}', fullscreen: '全屏', picture: '保存图片',
  link: '复制此视角的链接', copied: '链接已复制。', settings: '设置', help: '帮助', statistics: '统计',
  close: '关闭', cancel: '取消', quality: '画质', automatic: '自动', sharp: '清晰', fast: '快速',
  splats: '泼溅点上限', all: '全部', harmonics: '球谐函数阶数', background: '背景',
  scene: '场景：拖动旋转，双指或右键移动，捏合或滚轮缩放，W A S D 飞行',
  drop: '将场景拖放到这里，或打开一个', reading: '正在加载 {0}', decoding: '正在解码 {0}', left: '剩余 {0} 秒',
  memory: '内存不足，无法打开此场景。', network: '无法获取场景。',
  read: '场景没有完整到达。', damaged: '这不是场景，或者已损坏。',
  start: '查看器无法启动。', files: '此场景由多个文件组成，请一起选择全部文件。',
  webgl: '此浏览器没有绘制所需的 WebGL 2，较新的浏览器有。',
  lost: '正在恢复显卡…', reduced: '共 {1} 个泼溅点，显示 {0} 个：空间不足。',
  helpTouch: '单指旋转，双指移动，捏合缩放，扭转倾斜。双击可注视某处。',
  helpMouse: '左键旋转，右键移动，滚轮缩放，双击注视某处。',
  helpKeys: 'W A S D 或方向键飞行，Q E 下降和上升，+ − 速度；O 环绕，F 翻转，R 起始。',
};
const ko = {
  open: '장면 열기', reset: '처음 시점으로', turn: '자동 회전', walk: '걷기', flip: '위아래 뒤집기', save: '이 시점 저장',
  kept: '저장한 시점', view: '시점 {0}', forget: '시점 {0} 삭제', fullscreen: '전체 화면', picture: '그림 저장',
  link: '이 시점의 링크 복사', copied: '링크를 복사했습니다.', settings: '설정', help: '도움말', statistics: '통계',
  close: '닫기', cancel: '취소', quality: '품질', automatic: '자동', sharp: '선명', fast: '빠름',
  splats: '최대 스플랫 수', all: '모두', harmonics: '구면 조화 함수 차수', background: '배경',
  scene: '장면: 끌어서 회전, 두 손가락 또는 오른쪽 단추로 이동, 오므리거나 휠로 확대, W A S D 로 비행',
  drop: '여기에 장면을 놓거나 여세요', reading: '{0} 불러오는 중', decoding: '{0} 푸는 중', left: '{0}초 남음',
  memory: '이 장면에 필요한 메모리가 부족합니다.', network: '장면을 가져올 수 없습니다.',
  read: '장면이 모두 도착하지 않았습니다.', damaged: '장면이 아니거나 손상되었습니다.',
  start: '뷰어를 시작할 수 없습니다.', files: '이 장면은 여러 파일로 되어 있습니다. 모두 함께 선택하세요.',
  webgl: '이 브라우저에는 그리는 데 필요한 WebGL 2가 없습니다. 더 새로운 브라우저에는 있습니다.',
  lost: '그래픽을 복구하는 중…', reduced: '{1}개 중 {0}개의 스플랫을 표시합니다. 더 이상 공간이 없습니다.',
  helpTouch: '한 손가락으로 회전, 두 손가락으로 이동, 오므려 확대, 비틀어 기울입니다. 두 번 두드리면 그곳을 봅니다.',
  helpMouse: '왼쪽 단추로 회전, 오른쪽 단추로 이동, 휠로 확대, 두 번 누르면 그곳을 봅니다.',
  helpKeys: 'W A S D 나 화살표로 비행, Q E 아래와 위, + − 속도, O 회전, F 뒤집기, R 처음.',
};

export const languages = {en, de, fr, es, pt, ja, zh, ko};

/** The texts of the first of these languages that there is. */
export function textsFor(wanted = navigator.languages ?? ['en']) {
  for (const tag of wanted) {
    const found = Object.keys(languages).find((language) => tag.toLowerCase().startsWith(language));
    if (found) return {language: found, texts: languages[found]};
  }
  return {language: 'en', texts: en};
}

/** A text with what stands for {0}, {1} … */
export const fill = (text, ...values) => text.replace(/\{(\d)\}/g, (_, i) => String(values[i]));
