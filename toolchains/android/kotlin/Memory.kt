// Memory that C sees, and what keeps it there. What the generated classes stand on.
//
// A buffer of Java is kept while an object that points into it is: a struct keeps what its pointers name, and a call keeps its
// arguments. What was closed throws, also where a struct still names it. One scene belongs to one thread at a time.
package org.sandglass

import java.io.Closeable
import java.nio.ByteBuffer
import java.nio.ByteOrder

/** The library refused; the message is its sentence: what is wrong, where, and what to do. */
class SandglassException(val status: Int, sentence: String?) : RuntimeException(sentence)

/** What a pointer leads to: a buffer, a struct, a handle. */
abstract class Memory {
  abstract val address: Long
}

private fun direct(bytes: Int) = ByteBuffer.allocateDirect(bytes).order(ByteOrder.nativeOrder())

/** Bytes of the app for C to read or write: the whole of a direct buffer. */
class Buffer(val bytes: ByteBuffer) : Memory() {
  /** As many bytes, zero. */
  constructor(size: Int) : this(direct(size))

  init { require(bytes.isDirect && bytes.order() == ByteOrder.nativeOrder()) { "the buffer is not direct, or not in native order" } }
  override val address: Long = Native.address(bytes)
}

/** Structs that lie together. */
class Span(bytes: ByteBuffer) {
  constructor(size: Int) : this(direct(size))

  private val buffer = Buffer(bytes)
  private val b = bytes
  private val places = ArrayList<Int>()
  private val named = ArrayList<Memory>()
  internal val address: Long
    get() {
      for (i in places.indices) b.putLong(places[i], named[i].address)
      return buffer.address
    }
  internal fun kept(at: Int): Memory? = places.indexOf(at).let { if (it < 0) null else named[it] }
  internal fun keep(at: Int, of: Memory?) {
    b.putLong(at, of?.address ?: 0L)
    val i = places.indexOf(at)
    if (i >= 0) { places.removeAt(i); named.removeAt(i) }
    if (of != null) { places.add(at); named.add(of) }
  }
  internal fun copy(at: Int, from: Span, begin: Int, size: Int) {
    for (i in 0 until size) b.put(at + i, from.b.get(begin + i))
    for (i in from.places.indices) if (from.places[i] in begin until begin + size) keep(at + from.places[i] - begin, from.named[i])
  }
  internal fun u8(at: Int) = b.get(at).toInt() and 0xff
  internal fun u8(at: Int, to: Int) { b.put(at, to.toByte()) }
  internal fun i8(at: Int) = b.get(at).toInt()
  internal fun i8(at: Int, to: Int) { b.put(at, to.toByte()) }
  internal fun u16(at: Int) = b.getShort(at).toInt() and 0xffff
  internal fun u16(at: Int, to: Int) { b.putShort(at, to.toShort()) }
  internal fun i16(at: Int) = b.getShort(at).toInt()
  internal fun i16(at: Int, to: Int) { b.putShort(at, to.toShort()) }
  internal fun i32(at: Int) = b.getInt(at)
  internal fun i32(at: Int, to: Int) { b.putInt(at, to) }
  internal fun i64(at: Int) = b.getLong(at)
  internal fun i64(at: Int, to: Long) { b.putLong(at, to) }
  internal fun f32(at: Int) = b.getFloat(at)
  internal fun f32(at: Int, to: Float) { b.putFloat(at, to) }
  internal fun f64(at: Int) = b.getDouble(at)
  internal fun f64(at: Int, to: Double) { b.putDouble(at, to) }
}

/** A struct at a place of a span. */
abstract class Struct(val span: Span, val at: Int, private val size: Int) : Memory() {
  override val address: Long get() = span.address + at
  /** Takes all of another struct of this kind. */
  fun set(from: Struct) {
    require(from.javaClass == javaClass) { "a struct takes only its own kind" }
    span.copy(at, from.span, from.at, size)
  }
}

/** A fixed array of floats in a struct. */
class Floats internal constructor(private val span: Span, private val at: Int, val count: Int) {
  operator fun get(i: Int) = span.f32(element(at, i, count, 4))
  operator fun set(i: Int, to: Float) = span.f32(element(at, i, count, 4), to)
  fun set(vararg to: Float) { sized("the array", to, count); for (i in 0 until count) this[i] = to[i] }
  fun toArray() = FloatArray(count) { this[it] }
}

/** An array of pointers, to structs or handles. */
class Pointers(vararg of: Memory) : Memory() {
  private val span = Span(8 * of.size)
  init { of.forEachIndexed { i, one -> span.keep(8 * i, one) } }
  override val address: Long get() = span.address
}

/** A handle and the block that it lives in. */
abstract class Owned internal constructor(private val kind: String, bytes: Long, create: (Memory, Long, Memory) -> Unit) : Memory(), Closeable {
  private var block: ByteBuffer? = null
  private var start = 0L
  private var handle = 0L

  init {
    if (bytes > Int.MAX_VALUE - SANDGLASS_BLOCK_ALIGNMENT) throw SandglassException(SANDGLASS_ERROR_MEMORY_TOO_SMALL, "a block of $bytes bytes is beyond 2 GiB: lower the capacities")
    val whole = direct(bytes.toInt() + SANDGLASS_BLOCK_ALIGNMENT)
    val skip = (-Native.address(whole)).toInt() and (SANDGLASS_BLOCK_ALIGNMENT - 1)
    (whole as java.nio.Buffer).position(skip)  // ByteBuffer's own is newer than Android 24
    val aligned = Buffer(whole.slice().order(ByteOrder.nativeOrder()))
    val made = Span(8)
    create(aligned, bytes, object : Memory() { override val address get() = made.address })
    block = aligned.bytes
    start = aligned.address
    handle = made.i64(0)
  }

  protected val isOpen get() = handle != 0L
  override val address: Long get() = if (isOpen) handle else throw IllegalStateException("this $kind is closed")
  /** The library's memory behind an address that it told, such as a mesh's; in this block. It holds what is there until the next call. */
  fun memory(address: Long, size: Int): ByteBuffer {
    this.address
    if (size == 0) return direct(0)
    val all = block!!.duplicate()
    val begin = address - start
    require(size > 0 && begin >= 0 && begin + size <= all.capacity()) { "these bytes are not of this $kind" }
    (all as java.nio.Buffer).limit((begin + size).toInt()).position(begin.toInt())
    return all.slice().order(ByteOrder.nativeOrder())
  }
  private val kept = HashMap<String, Memory?>()
  internal fun keep(by: String, of: Memory?) { kept[by] = of }
  protected abstract fun release()
  override fun close() { release(); handle = 0L; block = null }
}

/** What says whether a point is inside a mesh: `inside` of a FieldDesc is MeshInside.test, and `insideUser` one of these. */
class MeshInside(mesh: Mesh, rule: Int) : Owned("MeshInside", block { Native.mesh_inside_bytes(mesh.address, mesh, rule, it.address, it) },
  { block, bytes, made -> Native.mesh_inside_create(mesh.address, mesh, rule, block.address, block, bytes, made.address, made) }) {
  init { keep("mesh", mesh) }
  override fun release() {}
  companion object { val test: Long get() = Native.insideTest() }
}

internal fun of(memory: Memory?) = memory?.address ?: 0L
internal fun sized(name: String, array: FloatArray?, count: Int): FloatArray? {
  require(array == null || array.size == count) { "$name has ${array!!.size} floats and takes $count" }
  return array
}
internal fun element(at: Int, i: Int, count: Int, size: Int): Int {
  if (i !in 0 until count) throw IndexOutOfBoundsException("$i is not below $count")
  return at + i * size
}
internal fun block(ask: (Memory) -> Unit): Long {
  val bytes = Buffer(8)
  ask(bytes)
  return bytes.bytes.getLong(0)
}
