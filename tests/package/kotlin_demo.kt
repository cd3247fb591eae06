// The Kotlin classes on this machine: the demo scene ends in the golden hash, the library's sentences are thrown, and nothing closed is used.
//   Demo SCENE_JSON HASH_FILE FRAMES [FRICTION]        FRICTION, the control, gives another hash
@file:JvmName("Demo")

import java.io.File
import java.nio.ByteBuffer
import java.nio.ByteOrder
import java.util.Base64
import kotlin.system.exitProcess
import org.sandglass.*

external fun clock(step: Long): Long

class SceneFile(path: String) {
  private val text = File(path).readText()
  fun number(name: String) = Regex("\"$name\": ([-0-9.e]+)").find(text)!!.groupValues[1].toDouble()
  fun array(name: String): Buffer {
    val bytes = Base64.getDecoder().decode(Regex("\"$name\": \"([^\"]*)\"").find(text)!!.groupValues[1])
    return Buffer(bytes.size).also { it.bytes.duplicate().put(bytes) }
  }
  fun points(name: String) = Points().also {
    it.positions = array(name + "s")
    it.velocities = array(name + "_velocities")
    it.count = (it.positions as Buffer).bytes.capacity() / 12
  }
}

fun check(condition: Boolean, sentence: String) {
  if (!condition) { println(sentence); exitProcess(1) }
}

inline fun <reified T : Throwable> throws(part: String, act: () -> Unit) {
  try { act() } catch (thrown: Throwable) {
    println("${thrown.javaClass.simpleName}: ${thrown.message}")
    return check(thrown is T && part in thrown.message!!, "this is not ${T::class.java.simpleName} with '$part'")
  }
  check(false, "nothing was thrown instead of '$part'")
}

fun main(arguments: Array<String>) {
  System.loadLibrary("clock")
  val file = SceneFile(arguments[0])
  val desc = SceneDesc()
  desc.clock.nowNs = clock(file.number("virtual_step_ns").toLong())
  with(desc.granular) {
    particleCapacity = file.number("particle_capacity").toInt()
    grainCapacity = file.number("grain_capacity").toInt()
    particleRadius = file.number("particle_radius").toFloat()
    grainRadius = file.number("grain_radius").toFloat()
    staticFriction = arguments.getOrNull(3)?.toFloat() ?: file.number("static_friction").toFloat()
    kineticFriction = file.number("kinetic_friction").toFloat()
  }
  val skinDesc = SkinDesc().also { Sandglass.skinDescDefault(it, desc.granular) }
  val castDesc = CastDesc().also { it.triangleCapacity = 1; it.meshCapacity = 1 }
  val scene = Scene(desc)
  val skin = Skin(skinDesc)
  val room = Room(RoomDesc())
  val cast = Cast(castDesc)
  scene.add(file.points("particle"), file.points("grain"))

  val input = FrameInput()
  val report = FrameReport()
  val mesh = SkinMesh()
  input.timeStep = file.number("frame_step").toFloat()
  input.budgetNs = (file.number("budget_ms") * 1e6).toLong()
  input.grains = Grain.array(desc.granular.grainCapacity)[0]
  input.grainCapacity = desc.granular.grainCapacity
  input.colliders = Collider.array(1)[0].also { it.rotation.set(0f, 0f, 0f, 1f) }
  input.colliderCount = 1
  input.room = room
  repeat(arguments[2].toInt()) {
    if (it % 30 == 0) System.gc()  // nothing that C sees goes with what Kotlin forgets
    scene.frame(input, report)
  }
  val hash = "0x%016x".format(scene.hash())
  val golden = File(arguments[1]).readLines().first { it.startsWith(arguments[2] + " ") }.split(" ")[1]
  println("${Sandglass.isaName(scene.isa())}: hash $hash after ${report.frame} frames")
  check(hash == golden, "it differs from the golden $golden")

  // A save and a skin, which the hash says nothing of.
  val saved = Buffer(scene.saveBytes().toInt())
  val written = Buffer(8)
  scene.save(saved, saved.bytes.capacity().toLong(), written)
  scene.reset()
  scene.restore(saved, written.bytes.getLong(0))
  check("0x%016x".format(scene.hash()) == golden, "what was restored has another hash")
  input.skin = skin
  input.casts = Pointers(cast)
  input.castCount = 1
  repeat(60) { scene.frame(input, report) }
  skin.getMesh(mesh)
  var vertices = 0
  for (i in 0 until mesh.chunkCount) {
    val chunk = SkinChunk(Span(skin.memory(mesh.chunks + i * SkinChunk.SIZE, SkinChunk.SIZE)), 0)
    vertices += skin.memory(chunk.vertices, chunk.vertexCount * SkinVertex.SIZE).capacity() / SkinVertex.SIZE
  }
  println("$vertices vertices in ${mesh.chunkCount} chunks")
  check(vertices > 100 && vertices == mesh.vertexCount, "the mesh has ${mesh.vertexCount} vertices, and its chunks $vertices")
  throws<IllegalArgumentException>("not of this Skin") { skin.memory(mesh.chunks, Int.MAX_VALUE) }

  // A field, whose mesh the library reads through its own function.
  val tetrahedron = Mesh()
  tetrahedron.vertices = Buffer(48).also { it.bytes.asFloatBuffer().put(floatArrayOf(0f, 0f, 0f, 1f, 0f, 0f, 0f, 1f, 0f, 0f, 0f, 1f)) }
  tetrahedron.vertexCount = 4
  tetrahedron.indices = Buffer(48).also { it.bytes.asIntBuffer().put(intArrayOf(0, 2, 1, 0, 1, 3, 0, 3, 2, 1, 2, 3)) }
  tetrahedron.triangleCount = 4
  val fieldDesc = FieldDesc()
  fieldDesc.mesh = tetrahedron
  fieldDesc.inside = MeshInside.test
  fieldDesc.insideUser = MeshInside(tetrahedron, SANDGLASS_INSIDE_WINDING)
  fieldDesc.boundsMin.set(-0.5f, -0.5f, -0.5f)
  fieldDesc.boundsMax.set(1.5f, 1.5f, 1.5f)
  fieldDesc.spacing = 0.1f
  fieldDesc.band = 0.3f
  val depth = Field(fieldDesc).use { it.distance(floatArrayOf(0.1f, 0.2f, 0.2f), null) }
  check(Math.abs(depth + 0.1f) < 0.02f, "0.1 m inside the tetrahedron the field says $depth")

  throws<SandglassException>("particle_radius") { Scene(SceneDesc().also { it.granular.particleCapacity = 1; it.granular.particleRadius = -1f }) }
  throws<SandglassException>("gravity") { scene.setGravity(floatArrayOf(0f, Float.NaN, 0f)) }
  throws<SandglassException>("friction") { scene.setFriction(-1f, 0f) }
  throws<IllegalArgumentException>("gravity has 2 floats and takes 3") { scene.setGravity(floatArrayOf(0f, 1f)) }
  throws<IndexOutOfBoundsException>("3 is not below 3") { desc.gravity[3] = 0f }
  throws<IllegalArgumentException>("not direct") { Buffer(ByteBuffer.allocate(8).order(ByteOrder.nativeOrder())) }
  skin.close()
  throws<IllegalStateException>("this Skin is closed") { scene.frame(input, report) }
  input.skin = null
  scene.use { it.frame(input, report) }
  scene.close()
  throws<IllegalStateException>("this Scene is closed") { scene.frame(input, report) }
}
