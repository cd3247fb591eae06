// The Kotlin classes on this machine: the demo scene ends in the golden hash, the library's sentences are thrown, and nothing closed is used.
//   Demo SCENE_JSON HASH_FILE FRAMES [FRICTION]        FRICTION, the control, gives another hash
@file:JvmName("Demo")

import java.io.File
import java.nio.ByteBuffer
import java.util.Base64
import kotlin.system.exitProcess
import org.sandglass.*

external fun clock(step: Long): Long

class SceneFile(path: String) {
  private val text = File(path).readText()
  private fun found(name: String, value: String) = Regex("\"$name\": \"?($value)").find(text)!!.groupValues[1]
  fun number(name: String) = found(name, "[-0-9.e]+").toDouble()
  fun array(name: String): Buffer {
    val bytes = Base64.getDecoder().decode(found(name, "[^\"]*"))
    return Buffer(bytes.size).also { it.bytes.duplicate().put(bytes) }
  }
  fun points(name: String) = Points().also {
    it.positions = array("${name}s")
    it.velocities = array("${name}_velocities")
    it.count = (it.positions as Buffer).bytes.capacity() / 12
  }
}

fun check(condition: Boolean, sentence: String) {
  if (!condition) { println(sentence); exitProcess(1) }
}

inline fun <reified T : Throwable> throws(part: String, act: () -> Unit) {
  val thrown = try { act(); null } catch (thrown: Throwable) { thrown }
  println("$thrown")
  check(thrown is T && part in thrown.message!!, "that is not ${T::class.java.simpleName} with '$part'")
}

fun main(arguments: Array<String>) {
  System.loadLibrary("clock")
  val file = SceneFile(arguments[0])
  val desc = SceneDesc()
  desc.clock.nowNs = clock(file.number("virtual_step_ns").toLong())
  with(desc.granular) {
    particleCapacity = file.number("particle_capacity").toInt()
    grainCapacity = file.number("grain_capacity").toInt()
    grainRadius = file.number("grain_radius").toFloat()
    staticFriction = arguments.getOrNull(3)?.toFloat() ?: file.number("static_friction").toFloat()
    kineticFriction = file.number("kinetic_friction").toFloat()
  }
  val scene = Scene(desc)
  val skin = Skin(SkinDesc().also { Sandglass.skinDescDefault(it, desc.granular) })
  scene.add(file.points("particle"), file.points("grain"))
  val input = FrameInput()
  val report = FrameReport()
  input.timeStep = file.number("frame_step").toFloat()
  input.budgetNs = (file.number("budget_ms") * 1e6).toLong()
  input.grains = Grain.array(desc.granular.grainCapacity)[0]
  input.grainCapacity = desc.granular.grainCapacity
  input.colliders = Collider().also { it.rotation[3] = 1f }
  input.colliderCount = 1
  repeat(arguments[2].toInt()) {
    if (it % 30 == 0) System.gc()  // nothing that C sees goes with what Kotlin forgets
    scene.frame(input, report)
  }
  val hash = "0x%016x".format(scene.hash())
  println("${Sandglass.isaName(scene.isa())}: hash $hash after ${report.frame} frames")
  check("${arguments[2]} $hash" in File(arguments[1]).readLines(), "it differs from the golden one")

  // Memory of the library, handles in an input, arrays of handles.
  input.skin = skin
  input.room = Room(RoomDesc())
  input.casts = pointers(Cast(CastDesc().also { it.triangleCapacity = 1; it.meshCapacity = 1 }))
  input.castCount = 1
  repeat(60) { scene.frame(input, report) }
  val mesh = SkinMesh().also { skin.getMesh(it) }
  val chunks = List(mesh.chunkCount) { SkinChunk(Buffer(skin.memory(mesh.chunks + it * SkinChunk.SIZE, SkinChunk.SIZE)), 0) }
  val vertices = chunks.map { skin.memory(it.vertices, it.vertexCount * SkinVertex.SIZE).capacity() / SkinVertex.SIZE }.sum()
  check(vertices > 100 && vertices == mesh.vertexCount, "the mesh has ${mesh.vertexCount} vertices, and its chunks $vertices")

  throws<SandglassException>("particle_radius") { Scene(SceneDesc().also { it.granular.particleCapacity = 1; it.granular.particleRadius = -1f }) }
  throws<SandglassException>("gravity") { scene.setGravity(Floats(0f, Float.NaN, 0f)) }
  throws<IllegalArgumentException>("2 floats where 3 are taken") { scene.setGravity(Floats(0f, 1f)) }
  throws<IllegalArgumentException>("not of this Skin") { skin.memory(mesh.chunks, Int.MAX_VALUE) }
  throws<IllegalArgumentException>("not direct") { Buffer(ByteBuffer.allocate(8)) }
  throws<IndexOutOfBoundsException>("3 is not below 3") { desc.gravity[3] = 0f }
  skin.close()
  throws<IllegalStateException>("this Skin is closed") { scene.frame(input, report) }
  input.skin = null
  scene.use { it.frame(input, report) }
  throws<IllegalStateException>("this Scene is closed") { scene.frame(input, report) }
}
